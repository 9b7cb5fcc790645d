"""Learning laws, each a small object that maps (u_k, e_k) to u_{k+1}."""
