"""Foreign calls of XLA for `robot_dynamics.jax`, with their rules of differentiation."""
