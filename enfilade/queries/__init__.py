"""A question in, ranked matches out."""
