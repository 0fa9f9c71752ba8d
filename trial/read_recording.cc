#include "trial/read_recording.h"
