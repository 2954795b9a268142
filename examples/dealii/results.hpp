/// @file
/// Tables that a run writes.
#ifndef MYOGROWTH_DEALII_RESULTS_HPP
#define MYOGROWTH_DEALII_RESULTS_HPP

#include <string>

namespace muscle {

/// Writes a whole file in the place of an older one, which is there until the new one is whole.
void replace_file(const std::string& path, const std::string& text);
void append(const std::string& path, const std::string& text);

}  // namespace muscle

#endif
