"""Stand-ins for devices, as they are on the wire or in their vendor's package."""
