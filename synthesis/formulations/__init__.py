"""From a question to laws and a size: formulate, solve, recover, and bound what could be."""
