"""What is between the truth and its measurement."""

from ffgym.effects.measurement.resolver_error import ResolverRipple as ResolverRipple
