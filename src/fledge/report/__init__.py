"""What people look at: plots, numbers, verdicts on the paper, pages, a single flight."""
