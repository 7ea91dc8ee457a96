"""The parts of bench/performance: programs and their reports, the claims about speed, and the page."""
