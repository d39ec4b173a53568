"""Many runs over states and parameters."""
