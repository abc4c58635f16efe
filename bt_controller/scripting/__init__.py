"""The script language of BehaviorTree.CPP's files, and the nodes with scripts."""
