// Words for messages: the nearest name to a misspelt one, lists, and numbers
// with as few digits as tell them.

#include <emmy/base/text.h>

#include <cstdlib>
#include <limits>

#include "../check.h"

using namespace emmy;
using namespace emmy::test;

int
main()
{
  const std::vector<std::string> names = {"Density", "Model", "Names"};
  check(nearest_name("Densty", names) == "Density", "a missing letter");
  check(nearest_name("DENSITY", names) == "Density", "case does not count");
  check(nearest_name("Denisty", names) == "Density", "exchanged letters");
  check(nearest_name("Mode", names) == "Model", "the nearest wins");
  check(nearest_name("Viscosity", names).empty(), "nothing is near");
  check(nearest_name("ab", {"xy"}).empty(), "no letter in common");
  check(nearest_name("", names).empty() && nearest_name("x", {}).empty(),
        "nothing to compare");
  check(nearest_name("Gost stabilization", {"Ghost stabilisation"}) != "",
        "longer names may differ more");

  check(join({}) == "" && join({"a"}) == "a" &&
          join({"a", "", "b"}) == "a, , b",
        "join with commas");
  check(join({"a", "a"}, "/") == "a/a", "join equal items");

  check(shortest(0.1) == "0.1" && shortest(-5.) == "-5", "shortest decimal");
  for (const double x : {1. / 3., 1e22, 5e-324, -1.7976931348623157e308})
    check(std::strtod(shortest(x).c_str(), nullptr) == x,
          "reads back the same: " + shortest(x));
  check(shortest(std::numeric_limits<double>::infinity()) == "inf", "inf");
  return report();
}
