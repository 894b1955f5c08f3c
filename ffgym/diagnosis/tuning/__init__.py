"""All numbers of a description, fitted to recordings together."""

from ffgym.diagnosis.tuning.fit import tuned as tuned
