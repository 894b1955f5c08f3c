"""Parts of model feed-forward: what physical effects ask of the drives beyond elasticity and LuGre friction."""
