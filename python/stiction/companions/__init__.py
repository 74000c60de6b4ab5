"""Additional computations for a pair, stored in the directory of its result."""
