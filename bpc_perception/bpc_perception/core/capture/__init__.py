"""What the camera delivers: captures, regions of them, and their parts paired by stamp."""
