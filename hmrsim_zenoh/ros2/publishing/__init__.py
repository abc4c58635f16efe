"""What ROS nodes see of a simulator: its nodes and endpoints, and messages on topics."""
