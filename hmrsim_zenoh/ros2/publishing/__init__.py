"""The nodes, endpoints and topics of a simulator, as ROS nodes see them."""
