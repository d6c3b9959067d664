"""Files of paths, tool poses and robot programs."""
