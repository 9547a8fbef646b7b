#include "server/cli/cli.h"

int main(int argc, char** argv) {
  return isochor::run_cli(argc, argv);
}
