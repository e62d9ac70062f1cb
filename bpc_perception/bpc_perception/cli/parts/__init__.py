"""What commands are made of: options, output, and the nodes that they run."""
