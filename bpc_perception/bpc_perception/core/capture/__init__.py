"""What the camera delivers: one capture, a region of it, its parts paired by stamp."""
