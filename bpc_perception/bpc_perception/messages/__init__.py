"""Convert between ROS messages and core types: only here messages meet arrays."""
