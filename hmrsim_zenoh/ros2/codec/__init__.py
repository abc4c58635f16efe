"""ROS types from the message models: their serialization, descriptions and hashes in each distribution."""
