"""What bench/performance is made of: running the program, the claims, and the page they are written to."""
