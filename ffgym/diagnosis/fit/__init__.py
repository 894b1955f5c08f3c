"""From a candidate that explains to an effect with sizes."""
