"""Between ROS messages and the core: the only place where messages meet arrays."""
