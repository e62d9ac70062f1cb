"""The robot: its kinematics, poses and clock, and where the camera is mounted."""
