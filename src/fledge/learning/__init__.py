"""The method: demonstrations of sub-tasks, fused (Algorithm 1), and a network trained on them."""
