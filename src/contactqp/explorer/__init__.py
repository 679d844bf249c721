"""A page on which loads and supports are moved by sliders, solved and proven anew in the reader's own browser."""
