#include "tools/mission/xml.h"

#include <fmt/format.h>

#include "builder/error.h"
#include "builder/ingest/gdal.h"

namespace landfix::mission {

XmlDocument::XmlDocument(const std::string& text, const std::string& file) : tree_(nullptr) {
  if (text.find("<!ENTITY") != std::string::npos) {
    throw Error(ExitCode::kBadInput,
                fmt::format("{}: expected XML that declares no entities, found <!ENTITY; no program "
                            "for missions needs them: export the file again",
                            file));
  }
  const ingest::GdalMessages messages;
  tree_.reset(CPLParseXMLString(text.c_str()));
  for (root_ = element_from(tree_.get()); root_ && root_->pszValue[0] == '?';) root_ = next_element(root_);
  if (!root_) {
    throw Error(ExitCode::kBadInput,
                fmt::format("{}: expected XML, found: {}; the file is cut off or damaged: copy it "
                            "or export it again",
                            file, messages.text().empty() ? "no element" : messages.text().substr(0, 200)));
  }
}

std::string local_name(const CPLXMLNode* element) {
  const std::string name = element->pszValue;
  return name.substr(name.find(':') + 1);
}

const CPLXMLNode* element_from(const CPLXMLNode* node) {
  while (node && node->eType != CXT_Element) node = node->psNext;
  return node;
}

std::string text_of(const CPLXMLNode* element) {
  std::string text;
  for (const CPLXMLNode* node = element->psChild; node; node = node->psNext) {
    if (node->eType == CXT_Text) text += node->pszValue;
  }
  return text;
}

std::optional<std::string> child_text(const CPLXMLNode* parent, const std::string& name) {
  for (const CPLXMLNode* child = first_element(parent); child; child = next_element(child)) {
    if (local_name(child) == name) return text_of(child);
  }
  return std::nullopt;
}

std::optional<std::string> attribute(const CPLXMLNode* element, const std::string& name) {
  for (const CPLXMLNode* node = element->psChild; node; node = node->psNext) {
    if (node->eType == CXT_Attribute && node->pszValue == name) return node->psChild ? node->psChild->pszValue : "";
  }
  return std::nullopt;
}

}  // namespace landfix::mission
