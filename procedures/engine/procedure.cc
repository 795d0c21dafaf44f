#include "procedures/engine/procedure.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include "procedures/engine/commands.h"
#include "procedures/engine/declaration.h"
#include "procedures/engine/sandbox.h"
#include "procedures/engine/script_error.h"
#include "procedures/engine/text.h"

namespace gyrobench::procedures {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMaxSource = std::size_t{1} << 20;

bool IsName(const std::string& name) {
  return !name.empty() && name.size() <= 60 &&
         std::all_of(name.begin(), name.end(), [](unsigned char c) {
           return c < 0x80 && (std::isalnum(c) != 0 || c == '_' || c == '-');
         });
}

std::string ReadSource(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string source(kMaxSource + 1, '\0');
  if (in) in.read(source.data(), static_cast<std::streamsize>(source.size()));
  if (!in.is_open() || in.bad() || !fs::is_regular_file(file)) {
    throw DataError(file.string() + ": cannot be read");
  }
  source.resize(static_cast<std::size_t>(in.gcount()));
  return source;
}

}  // namespace

Procedure::Procedure(ProcedureInfo info, std::string source)
    : info_(std::move(info)), source_(std::move(source)) {}

Procedure Procedure::FromSource(const std::string& name, const fs::path& file, std::string source) {
  const std::string shown = file.filename().string();
  if (!IsName(name)) {
    throw ScriptError(shown, 0, "a procedure's name consists of letters, digits, _ and -");
  }
  if (source.size() > kMaxSource || !IsText(source)) {
    throw ScriptError(shown, 0, "expected Lua source of at most 1 MB in UTF-8");
  }
  Sandbox sandbox(shown, {});
  InstallCommands(sandbox.thread());
  sandbox.Load(source);
  ProcedureInfo info;
  try {
    info = ReadDeclaration(sandbox.thread());
  } catch (const Error& error) {
    throw ScriptError(shown, 0, error.what());
  }
  info.name = name;
  info.file = file;
  return {std::move(info), std::move(source)};
}

Procedure Procedure::Load(const fs::path& file) {
  return FromSource(file.stem().string(), file, ReadSource(file));
}

ProcedureLibrary::ProcedureLibrary(std::vector<fs::path> directories)
    : directories_(std::move(directories)) {}

std::map<std::string, fs::path> ProcedureLibrary::Files() const {
  std::map<std::string, fs::path> files;
  for (const fs::path& directory : directories_) {
    std::error_code missing;
    for (const auto& entry : fs::directory_iterator(directory, missing)) {
      if (entry.path().extension() == ".lua") files.emplace(entry.path().stem(), entry.path());
    }
  }
  return files;
}

std::vector<ProcedureInfo> ProcedureLibrary::List() const {
  std::vector<ProcedureInfo> list;
  for (const auto& [name, file] : Files()) {
    try {
      list.push_back(Procedure::Load(file).info());
    } catch (const Error& error) {
      ProcedureInfo info;
      info.name = name;
      info.file = file;
      info.problem = error.what();
      list.push_back(std::move(info));
    }
  }
  return list;
}

Procedure ProcedureLibrary::Find(const std::string& name) const {
  const auto files = Files();
  if (const auto found = files.find(name); found != files.end()) {
    return Procedure::Load(found->second);
  }
  std::vector<std::string> names;
  for (const auto& [known, file] : files) names.push_back(known);
  std::vector<std::string> searched;
  for (const fs::path& directory : directories_) searched.push_back(directory.string());
  throw UnknownProcedure(fmt::format(
      "there is no procedure {}{}; known: {} (looked for NAME.lua in {})", Show(Value(name)),
      DidYouMean(name, names), names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", ")),
      searched.empty() ? "no directory" : fmt::format("{}", fmt::join(searched, ", "))));
}

}  // namespace gyrobench::procedures
