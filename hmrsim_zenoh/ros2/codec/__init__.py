"""ROS types from the message models: their serialisation, descriptions and hashes in each distribution."""
