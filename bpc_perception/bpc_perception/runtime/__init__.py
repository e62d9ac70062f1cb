"""What every process of the suite needs: how it starts, says how it is, and ends."""
