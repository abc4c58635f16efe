"""The requests of ROS clients, and the replies to them."""
