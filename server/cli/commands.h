#pragma once
#include "server/cli/context.h"

namespace isochor {

/// One function a command: it adds its options to the application and sets context.run when it is named.
void add_serve_command(CLI::App& app, CliContext& context);
void add_mesh_command(CLI::App& app, CliContext& context);
void add_simulate_command(CLI::App& app, CliContext& context);
void add_report_command(CLI::App& app, CliContext& context);
void add_stability_command(CLI::App& app, CliContext& context);
void add_info_command(CLI::App& app, CliContext& context);
void add_formats_command(CLI::App& app, CliContext& context);

/// Hidden: writes the man page and the shell completion from the tree of commands itself.
void add_generate_command(CLI::App& app, CliContext& context);

/// roff and shell code for the whole tree.
std::string man_page(const CLI::App& app);
std::string bash_completion(const CLI::App& app);
std::string zsh_completion(const CLI::App& app);

}  // namespace isochor
