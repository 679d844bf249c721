"""What is written beside the problems as it stands: a reader, and the dedication to the public domain."""
