"""Reading of descriptions from TOML: rules, quantities with their origin, drafts, parameter files."""
