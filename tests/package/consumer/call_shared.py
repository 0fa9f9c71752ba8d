"""Loads a shared library and calls its main with one argument: call_shared.py LIBRARY ARGUMENT."""
import ctypes
import os
import sys

library = ctypes.CDLL(os.path.abspath(sys.argv[1]))
arguments = (ctypes.c_char_p * 3)(*(word.encode() for word in sys.argv[1:]), None)
status = library.main(2, arguments)
library.fflush(None)
sys.exit(status)
