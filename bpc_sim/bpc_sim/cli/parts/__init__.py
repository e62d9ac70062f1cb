"""What the commands of the simulator are made of."""
