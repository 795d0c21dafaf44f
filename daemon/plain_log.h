// The daemon's log on standard error.
#pragma once

namespace gyrobench::daemon {

// Makes it the log of the program. What a script, a request or a device brings into a line is text
// there: bytes that are no UTF-8 and control characters, which a terminal would obey, show as
// U+FFFD.
void UsePlainLog();

}  // namespace gyrobench::daemon
