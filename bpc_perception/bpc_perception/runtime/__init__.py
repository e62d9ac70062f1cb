"""What every process of bpc needs to start, to report its state, and to end."""
