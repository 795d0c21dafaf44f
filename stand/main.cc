// gyrobench-stand.
#include "stand/stand_program.h"

int main(int argc, char** argv) { return gyrobench::stand::RunStandProgram(argc, argv); }
