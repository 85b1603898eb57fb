"""Changes of one place of the code at a time, for asking whether the hard cases notice them."""
