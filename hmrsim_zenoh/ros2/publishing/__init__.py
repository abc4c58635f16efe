"""What ROS hears of us: nodes and endpoints, messages on topics."""
