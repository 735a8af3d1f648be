"""Reports as pages and notebooks, exports of runs for other programs, and the reproduction of the paper."""
