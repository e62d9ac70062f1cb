"""The paper's simulation study: its table of eight cases and its two sweeps."""
