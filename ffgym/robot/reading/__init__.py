"""From TOML to a description: rules, quantities with their origin, drafts, parameter files."""
