"""What everything else stands on: checks of arguments, rounding, text, progress, threads, files."""
