from .fit import tuned as tuned
