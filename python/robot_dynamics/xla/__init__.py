"""How `robot_dynamics.jax` reaches the library: XLA's foreign calls, and what JAX has to know of them."""
