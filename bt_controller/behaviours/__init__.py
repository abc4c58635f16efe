"""Behaviors for trees, one file each; `bt_controller.core.action_leaf` serves all other actions."""
