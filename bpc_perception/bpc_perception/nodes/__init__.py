"""The ROS nodes: each converts, calls the core, converts and publishes."""
