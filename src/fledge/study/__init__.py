"""The paper's experiments: set-ups, test flights, scores, and what may be concluded from them."""
