// SPDX-License-Identifier: Apache-2.0
// The module `scrim_ax`: compiles and runs expressions of OpenVDB AX (scrim/volume/ax_module.h).
#include "ax_together.h"

#include <scrim/volume/ax_module.h>
#include <scrim/volume/grid_editor.h>

#include <openvdb_ax/ast/Parse.h>
#include <openvdb_ax/ast/Scanners.h>
#include <openvdb_ax/compiler/Compiler.h>
#include <openvdb_ax/compiler/CustomData.h>
#include <openvdb_ax/compiler/Logger.h>
#include <openvdb_ax/compiler/VolumeExecutable.h>

#include <fmt/format.h>
#include <algorithm>
#include <exception>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <utility>

namespace {

namespace ax = openvdb::ax;
using scrim::AxProblem;
using scrim::AxUse;
using scrim::Together;

/// The parser recurses: text that is nested more deeply overflows its stack.
constexpr int kDeepest = 100;

/// AX's messages end with the place: "unexpected SEMICOLON 1:24".
AxProblem problemFrom(std::string text) {
    AxProblem problem;
    const std::size_t space = text.rfind(' '), colon = text.rfind(':');
    if (space != std::string::npos && colon != std::string::npos && colon > space + 1) {
        problem.line = std::atoi(text.c_str() + space + 1);
        problem.column = std::atoi(text.c_str() + colon + 1);
        if (problem.line > 0) text.erase(space);
    }
    for (std::size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at)) text.replace(at, 1, " ");
    constexpr std::string_view kException = "AXCompilerError: ";
    if (text.starts_with(kException)) text.erase(0, kException.size());
    if (text == "ed") text = "this is nested too deeply";  // what is left of bison's "memory exhausted"
    problem.text = std::move(text);
    problem.line = std::max(problem.line, 1);
    problem.column = std::max(problem.column, 1);
    return problem;
}

/// A logger whose messages are kept.
class Log {
  public:
    Log() : m_logger([this](const std::string& text) { m_problems.push_back(problemFrom(text)); }) {
        m_logger.setPrintLines(false);
        m_logger.setNumberedOutput(false);
        m_logger.setErrorPrefix("");
    }
    ax::Logger& logger() { return m_logger; }
    std::vector<AxProblem> take() { return std::exchange(m_problems, {}); }
    /// The place of a node of a tree that was parsed with this logger.
    AxProblem placeOf(const ax::ast::Node& node) {
        m_problems.clear();
        m_logger.error("", &node);
        return m_problems.empty() ? AxProblem{"", 1, 1} : m_problems.front();
    }

  private:
    std::vector<AxProblem> m_problems;
    ax::Logger m_logger;
};

/// A problem if brackets or operators nest too deeply to be parsed.
std::vector<AxProblem> nesting(const std::string& code) {
    int depth = 0, line = 1, column = 0;
    for (const char c : code) {
        ++column;
        if (c == '\n') ++line, column = 0;
        if (c == '(' || c == '{' || c == '[') ++depth;
        if (c == ')' || c == '}' || c == ']') --depth;
        if (depth > kDeepest) return {{fmt::format("brackets are nested more than {} deep", kDeepest), line, column}};
    }
    return {};
}

/// All grids that the code uses, each once, in the order of their first use.
std::vector<AxUse> usesOf(const ax::ast::Tree& tree, Log& log) {
    std::vector<const ax::ast::Attribute*> nodes;
    ax::ast::collectNodeType<ax::ast::Attribute>(tree, nodes);
    const auto registry = ax::AttributeRegistry::create(tree);
    std::vector<AxUse> uses;
    for (const ax::AttributeRegistry::AccessData& access : registry->data()) {
        AxUse use{access.name(), ax::ast::tokens::typeStringFromToken(access.type()), access.reads(), access.writes()};
        for (const auto* node : nodes) {
            if (node->name() != use.name || node->type() != access.type()) continue;
            const AxProblem place = log.placeOf(*node);
            use.line = place.line;
            use.column = place.column;
            break;
        }
        uses.push_back(std::move(use));
    }
    return uses;
}

/// Problems of grids that are used as two types, and of external variables that have no value of their type.
std::vector<AxProblem> misuses(const ax::ast::Tree& tree, const std::vector<AxUse>& uses,
                               const std::vector<scrim::AxVariable>& variables, Log& log) {
    std::vector<AxProblem> problems;
    std::map<std::string, std::string> types;
    for (const AxUse& use : uses) {
        const auto [known, isNew] = types.emplace(use.name, use.type);
        if (!isNew)
            problems.push_back(
                {fmt::format("grid '{}' is used as {} and as {}; expected one type", use.name, known->second, use.type),
                 use.line, use.column});
    }
    std::vector<const ax::ast::ExternalVariable*> nodes;
    ax::ast::collectNodeType<ax::ast::ExternalVariable>(tree, nodes);
    for (const auto* node : nodes) {
        const AxProblem place = log.placeOf(*node);
        const auto fail = [&](const std::string& text) { problems.push_back({text, place.line, place.column}); };
        const auto found = std::find_if(variables.begin(), variables.end(),
                                        [&](const scrim::AxVariable& v) { return v.name == node->name(); });
        const auto type = node->type();
        const bool number = type == ax::ast::tokens::FLOAT, vector = type == ax::ast::tokens::VEC3F;
        if (found == variables.end())
            fail(fmt::format("there is no parameter '{}'; expected it in [volume.parameters]", node->name()));
        else if (found->value.size() == 1 ? !number : !vector)
            fail(fmt::format("parameter '{0}' is {1}; expected {2}{0}", node->name(),
                             found->value.size() == 1 ? "a number" : "a vector",
                             found->value.size() == 1 ? "$" : "v$"));
    }
    return problems;
}

/// Problems of functions that work on points only, which the compiler refuses without a name or a place, and of numbers
/// drawn before any seed is given, which differ in every run, so that tiles and frames would not match.
std::vector<AxProblem> wrongCalls(const ax::ast::Tree& tree, Log& log) {
    static constexpr std::string_view kOfPoints[] = {"addtogroup", "deletepoint", "ingroup", "removefromgroup"};
    static constexpr std::string_view kDrawn[] = {"rand", "rand32"};
    const auto isOneOf = [](const auto& names, const std::string& name) {
        return std::find(std::begin(names), std::end(names), name) != std::end(names);
    };
    std::vector<const ax::ast::FunctionCall*> calls;
    ax::ast::collectNodeType<ax::ast::FunctionCall>(tree, calls);
    std::set<std::string> seeded;
    for (const auto* call : calls) {
        const std::string& name = call->name();
        if (!call->empty()) seeded.insert(name);
        std::string text;
        if (isOneOf(kOfPoints, name))
            text = fmt::format("{}() works on points; expected functions of voxels", name);
        else if (isOneOf(kDrawn, name) && !seeded.contains(name))
            text = fmt::format(
                "{0}() differs in every run; expected a seed, as in {0}(dot(getcoord(), {{1, 131, 17161}}))", name);
        if (text.empty()) continue;
        const AxProblem place = log.placeOf(*call);
        return {{text, place.line, place.column}};
    }
    return {};
}

/// True for an expression whose value is a whole number, as far as that can be seen. `whole`: names of variables.
bool isWhole(const ax::ast::Node& node, const std::vector<std::string>& whole) {
    using ax::ast::Node;
    const auto isIn = [](const auto& type) {
        return type == ax::ast::tokens::INT16 || type == ax::ast::tokens::INT32 || type == ax::ast::tokens::INT64;
    };
    switch (node.nodetype()) {
        case Node::ValueInt16Node:
        case Node::ValueInt32Node:
        case Node::ValueInt64Node:
            return true;
        case Node::LocalNode:
            return std::find(whole.begin(), whole.end(), static_cast<const ax::ast::Local&>(node).name()) !=
                   whole.end();
        case Node::AttributeNode:
            return isIn(static_cast<const ax::ast::Attribute&>(node).type());
        case Node::CastNode:
            return isIn(static_cast<const ax::ast::Cast&>(node).type());
        case Node::FunctionCallNode:
            return static_cast<const ax::ast::FunctionCall&>(node).name().starts_with("getcoord");
        case Node::UnaryOperatorNode:
        case Node::BinaryOperatorNode:
            for (std::size_t i = 0; i < node.children(); ++i)
                if (!isWhole(*node.child(i), whole)) return false;
            return true;
        default:
            return false;
    }
}

/// Takes whole exponents of pow() for floats: what LLVM 14 makes of a double and an integer crashes.
void avoidWholeExponents(const ax::ast::Tree& tree) {
    std::vector<const ax::ast::DeclareLocal*> variables;
    ax::ast::collectNodeType<ax::ast::DeclareLocal>(tree, variables);
    std::vector<std::string> whole;
    for (const auto* variable : variables)
        if (const auto type = variable->type();
            type == ax::ast::tokens::INT16 || type == ax::ast::tokens::INT32 || type == ax::ast::tokens::INT64)
            whole.push_back(variable->local()->name());
    std::vector<const ax::ast::FunctionCall*> calls;
    ax::ast::collectNodeType<ax::ast::FunctionCall>(tree, calls);
    for (const auto* call : calls)
        if (call->name() == "pow" && call->children() == 2 && isWhole(*call->child(1), whole))
            const_cast<ax::ast::FunctionCall*>(call)->replacechild(
                1, new ax::ast::Cast(call->child(1)->copy(), ax::ast::tokens::FLOAT));
}

class Program : public scrim::AxProgram {
  public:
    Program(std::vector<AxUse> uses, ax::VolumeExecutable::Ptr executable, Together together)
        : m_uses(std::move(uses)), m_executable(std::move(executable)), m_together(std::move(together)) {
        m_executable->setCreateMissing(false);
    }
    const std::vector<AxUse>& grids() const override { return m_uses; }
    void run(scrim::EditedGrids& grids) const override {
        if (!grids.grids.empty() && !m_together.run(grids.grids)) m_executable->execute(grids.grids);
    }

  private:
    std::vector<AxUse> m_uses;
    ax::VolumeExecutable::Ptr m_executable;
    Together m_together;
};

std::shared_ptr<ax::CustomData> customData(const std::vector<scrim::AxVariable>& variables) {
    auto data = std::make_shared<ax::CustomData>();
    for (const scrim::AxVariable& variable : variables) {
        const auto part = [&](std::size_t i) { return static_cast<float>(variable.value[i]); };
        if (variable.value.size() == 1)
            data->insertData(variable.name, openvdb::FloatMetadata(part(0)).copy());
        else
            data->insertData(variable.name, openvdb::Vec3SMetadata({part(0), part(1), part(2)}).copy());
    }
    return data;
}

scrim::AxCompiled compileParsed(const std::string& code, const std::vector<scrim::AxVariable>& variables) {
    Log places;  // asking for places counts as errors, so the compiler gets a log of its own
    const auto tree = ax::ast::parse(code.c_str(), places.logger());
    if (!tree) return {nullptr, places.take()};
    std::vector<AxUse> uses = usesOf(*tree, places);
    if (auto problems = misuses(*tree, uses, variables, places); !problems.empty()) return {nullptr, problems};
    if (auto problems = wrongCalls(*tree, places); !problems.empty()) return {nullptr, problems};
    Log log;
    const auto sound = ax::ast::parse(code.c_str(), log.logger());
    avoidWholeExponents(*sound);
    const auto executable =
        ax::Compiler::create()->compile<ax::VolumeExecutable>(*sound, log.logger(), customData(variables));
    if (!executable) return {nullptr, log.take()};
    Together together(uses);
    if (const auto joined = together.worthwhile() ? together.rewritten(code) : nullptr) {
        avoidWholeExponents(*joined);
        Log unheard;
        if (auto made =
                ax::Compiler::create()->compile<ax::VolumeExecutable>(*joined, unheard.logger(), customData(variables)))
            together.take(std::move(made));
    }
    return {std::make_shared<const Program>(std::move(uses), executable, std::move(together)), {}};
}

scrim::AxCompiled compile(const std::string& code, const std::vector<scrim::AxVariable>& variables) {
    if (auto problems = nesting(code); !problems.empty()) return {nullptr, problems};
    try {
        ax::initialize();
        scrim::AxCompiled out = compileParsed(code, variables);
        if (!out.program && out.problems.empty()) out.problems.push_back({"this is not AX", 1, 1});
        return out;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        return {nullptr, {problemFrom(error.what())}};
    }
}

}  // namespace

extern "C" __attribute__((visibility("default"))) const scrim::AxModule* scrim_ax_module_1() {
    static const scrim::AxModule module{compile};
    return &module;
}
