"""What watches over properties by temporal operators, one file each."""
