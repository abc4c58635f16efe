"""What ROS clients ask: requests in, replies out."""
