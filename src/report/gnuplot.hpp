#pragma once
// gnuplot as a child process.
#include <string>

namespace odeval::report {

/// What gnuplot prints when it reads the script. Nothing but the script has a say in it: no start-up file, no locale,
/// no file on disk. Throws MachineError when there is no gnuplot or it gives up.
std::string run_gnuplot(const std::string& script);

/// While there is one, this thread's figures are drawn by one gnuplot, which takes less time than one each. As parts of
/// a page (`page_svg`) they are the same to the byte, as long as all say the same of the terminal but for its size.
class OneGnuplot {
 public:
  OneGnuplot();
  ~OneGnuplot();
  OneGnuplot(const OneGnuplot&) = delete;
  OneGnuplot& operator=(const OneGnuplot&) = delete;
};

/// "gnuplot 5.4 patchlevel 4", or why there is none.
std::string gnuplot_version();

}  // namespace odeval::report
