"""Live thickness feedback for robotic bioprinting."""

__version__ = '0.1.0'
