#include "server/cli/commands.h"
#include "server/cli/data_folder.h"
#include "server/http/serve.h"

#include "core/parallel/parallel.h"

namespace isochor {
namespace {

void run_serve(CliContext& context, ServeOptions options, double memory_gib) {
  options.json = context.json;
  options.memory_limit = static_cast<std::int64_t>(memory_gib * (1 << 30));
  if (options.samples_folder.empty()) options.samples_folder = data_folder("samples").string();
  if (options.web_folder.empty()) options.web_folder = data_folder("web/bundle").string();
  set_thread_count(context.threads);
  context.exit_code = serve(options);
}

}  // namespace

void add_serve_command(CLI::App& app, CliContext& context) {
  CLI::App* command = add_command(app, context, "serve", "Serve the page and the HTTP API");
  const auto options = std::make_shared<ServeOptions>();
  const auto memory_gib = std::make_shared<double>(4.0);
  command->add_option("--host", options->host, "Address to listen on; other than loopback needs --token")
      ->capture_default_str();
  command->add_option("--port", options->port, "Port; 0 takes a free one")
      ->check(CLI::Range(0, 65535))
      ->capture_default_str();
  command->add_option("--token", options->token,
                      "Secret that requests which change state must bring; made at launch by default");
  command->add_option("--memory", *memory_gib, "Limit of all models and simulations together")
      ->type_name("GIB")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  command->add_option("--samples", options->samples_folder,
                      "Folder of the samples instead of the one that ships");
  command->add_option("--web", options->web_folder, "Folder of the page instead of the one that ships");
  command->callback([&context, options, memory_gib] {
    context.run = [&context, options, memory_gib] { run_serve(context, *options, *memory_gib); };
  });
}

}  // namespace isochor
