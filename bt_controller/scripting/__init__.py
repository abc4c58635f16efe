"""The script language of BehaviorTree.CPP's files: what it says, and the nodes that have scripts."""
